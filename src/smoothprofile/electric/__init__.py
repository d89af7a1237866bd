"""Dielectric bodies in electric fields, on the staggered grid of the flow."""
