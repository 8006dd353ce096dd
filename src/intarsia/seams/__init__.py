"""Maps sewn by graph cuts, and any map improved by them: seams, repeats, striking things, cut elements."""
