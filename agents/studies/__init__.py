"""The paper's studies, each claim checked: ``coopenv study --help``.

Needs the extra ``analysis``.
"""
