"""Near-regular textures: mosaics of lattice blocks, best tiles, and walls laid brick by brick."""
