# What the stub generator leaves out: the exceptions (made with PyErr_NewException), the version, and private functions
# that the package uses itself.
_srmp.__suffix__:
    __version__: str

    def _did_you_mean(name: str, known: Sequence[str]) -> str: ...

    def _option_of_other_planner(name: str) -> str: ...

    class Error(Exception):
        """Base of every exception that srmp raises."""

    class InvalidArgument(Error, ValueError):
        """An argument was refused; nothing was changed."""

    class UnknownRobot(InvalidArgument, KeyError):
        """There is no robot of this name."""

    class WrongType(InvalidArgument, TypeError):
        """An argument has the wrong type, is missing or is not known."""

    class RobotWarning(UserWarning):
        """Something in the files of a robot was read but not used."""

    class FileError(Error, OSError):
        """A file is missing, unreadable or wrong."""

    class NotSupported(Error, NotImplementedError):
        """The request needs something that this version does not do yet."""

    class PlanningError(Error):
        """There is no trajectory: `status` says how the plan ended, the text why; `statistics`: see get_planning_stats."""

        status: Status
        statistics: dict[str, object]

    def _write_file(path: str | os.PathLike[str], text: str) -> None:
        """Writes a file completely or not at all. Raises FileError."""
