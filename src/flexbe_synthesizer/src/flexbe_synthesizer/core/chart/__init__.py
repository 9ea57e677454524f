"""The language: charts as values, and their XML, read and written."""
