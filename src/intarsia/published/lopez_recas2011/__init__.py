"""Near-regular textures as Lopez Recas 2011 lays them: square blocks at random, the gaps between them filled."""
