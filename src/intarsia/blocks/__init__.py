"""Near-regular textures from blocks of whole periods: the mosaic, and gap filling by random sampling."""
