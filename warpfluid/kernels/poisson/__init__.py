"""The pressure step: what solids and walls leave open, and the Poisson equation."""
