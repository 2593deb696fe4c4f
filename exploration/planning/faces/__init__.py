"""Contacts -> the faces they lie on, while there are few of them."""
