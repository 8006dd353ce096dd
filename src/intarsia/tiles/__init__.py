"""One tile, repeated: the best one of an exemplar, and how its copies lie."""
