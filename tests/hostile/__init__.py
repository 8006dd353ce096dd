"""Campaigns of mutated files and kills: `make fuzz N=1000`. No part of `make test`."""
