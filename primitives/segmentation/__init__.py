"""Contacts to smooth faces: proposals from a few contacts, weighed by evidence, labels that neighbors share."""
