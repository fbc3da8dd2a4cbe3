"""The published bistable sheets: cases, rows of the table, page and figure."""
