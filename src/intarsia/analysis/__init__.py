"""What is known of an exemplar, before anything is grown from it: features, elements, light, symmetry, rarity."""
