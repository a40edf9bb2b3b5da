"""Contacts that nobody stated."""
