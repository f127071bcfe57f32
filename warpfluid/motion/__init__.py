"""What the footage tells of movement: flow in each view, its lift into the volume, volumes carried along."""
