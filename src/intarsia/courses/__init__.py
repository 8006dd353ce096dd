"""Brickwork: courses of whole bricks along one vector, with joints that stay straight."""
