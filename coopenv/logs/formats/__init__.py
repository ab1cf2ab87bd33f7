"""File formats of recordings, each with its reader and its writer."""
