"""Rigid bodies on a grid: their state, their painted indicator, their loads and motion."""
