"""The published study as figures, tables and one page. Import ``files``; it brings matplotlib."""
