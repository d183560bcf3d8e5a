"""Renders the photographs of `sample_projects/` and the picks that go with them.

The package is the sample projects' independent truth: it imports nothing of plumbline and holds
its own ptlens formula, its own inverse and its own writers.
"""
