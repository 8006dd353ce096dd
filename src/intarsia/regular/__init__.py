"""Textures that repeat: mosaics of whole periods, one tile again and again, walls laid stone by stone."""
