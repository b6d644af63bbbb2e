"""Structural analysis of a mechanism: what is determined before its positions are solved."""
