"""Re = 0: steady Stokes flow, with rigid particles in it."""
