"""The six methods that the SHREC 2022 track on fitting primitives compares, made again from the paper's text.

Romanengo, Raffo, Biasotti, Falcidieno et al., "SHREC 2022: Fitting and recognition of simple geometric
primitives on point clouds", Computers & Graphics 107, 2022 (arXiv 2206.07636), section 3. One file a method;
`method.py` says what a method is, `parts/` holds what several of them are made of.
"""
