"""The two mistakes a caller can make; everything else is an outcome, not an error."""


class InvalidPointCloudError(ValueError):
    """The points cannot be a cloud of any allowed kind; the message holds the numbers that say why."""

    def __init__(self, message: str, field: str = "points") -> None:
        super().__init__(message)
        self.field = field


class InvalidOptionError(ValueError):
    """An option is unknown or out of its range; `field` names it."""

    def __init__(self, message: str, field: str) -> None:
        super().__init__(message)
        self.field = field
