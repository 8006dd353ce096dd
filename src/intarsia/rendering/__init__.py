"""Drawing a map: colours, mixing at seams, finishing, normals and magnification."""
