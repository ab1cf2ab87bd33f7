"""Settings of all tests."""

from hypothesis import settings

settings.register_profile("coopenv", deadline=None)  # on a busy machine any example may take long
settings.load_profile("coopenv")
