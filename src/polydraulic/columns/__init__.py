"""Text and Parquet files as columns of numbers: what a file is, one reading for a whole column, times of every common form.

Read `source` (bytes), `dialect` (delimiter, header, first row), `quotes` (cells that are quoted otherwise), `rows` (blocks of
text cells), `cells` and `survey` (numbers, one reading a column), `timestamps` and `local_clock` (times), `text_file` (all of it).
"""
