"""Methods and settings kept because a paper describes them, one package per document; only METHODS refers to them."""
