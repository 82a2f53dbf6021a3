"""The formats that are read, and the usual suffixes of their files."""

FORMATS = {
    "CSV": (".csv",),
    "XYZ": (".xyz",),
    "TXT": (".txt",),
    "PTS": (".pts",),
    "ASC": (".asc",),
    "NPY": (".npy",),
    "NPZ": (".npz",),
    "PLY": (".ply",),
    "PCD": (".pcd",),
    "LAS": (".las",),
    "LAZ": (".laz",),
    "E57": (".e57",),
    "STL": (".stl",),
    "OBJ": (".obj",),
    "GLB": (".glb",),
    "JSON": (".json",),
}
