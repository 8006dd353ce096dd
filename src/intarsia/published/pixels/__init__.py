"""Growth pixel by pixel: Efros and Leung 1999, Wei and Levoy 2000, Ashikhmin 2001, and what they share."""
