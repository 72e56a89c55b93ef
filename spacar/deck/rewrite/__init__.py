"""Decks from decks: the same mechanism divided, refined, renumbered, released, or with other numbers."""
