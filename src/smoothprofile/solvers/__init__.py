"""Direct and iterative solvers of elliptic problems on one grid."""
