"""The model: the nouns that the service works with."""
