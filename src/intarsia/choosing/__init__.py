"""Which method suits an exemplar: facts, rules, trials, and the score of a result."""
