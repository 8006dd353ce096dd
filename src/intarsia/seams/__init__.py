"""Maps sewn by graph cuts, and any map improved by them: seams, even use of the exemplar, cut elements."""
