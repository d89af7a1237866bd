"""An incompressible flow solver that has never heard of particles."""
