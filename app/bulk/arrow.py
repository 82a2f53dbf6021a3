"""pyarrow, where it is installed."""

from types import ModuleType


def arrow() -> ModuleType:
    """The module; raises `ImportError` with what to do where it is missing."""
    try:
        import pyarrow
    except ImportError as error:
        raise ImportError("Parquet needs an extra: pip install 'primfit[bulk]'") from error
    module: ModuleType = pyarrow
    return module
