# What the stub generator leaves out: the exceptions (made with PyErr_NewException), the version, and private functions
# that the package uses itself.
_srmp.__suffix__:
    __version__: str

    def _did_you_mean(name: str, known: Sequence[str]) -> str: ...

    class Error(Exception):
        """Base of everything that srmp raises."""

    class InvalidArgument(Error, ValueError):
        """An argument was refused; nothing was changed."""

    class UnknownRobot(InvalidArgument, KeyError):
        """There is nothing of a robot of this name."""

    class FileError(Error, OSError):
        """A file is missing, unreadable or wrong."""

    class NotSupported(Error, NotImplementedError):
        """Not done by this version yet."""

    class PlanningError(Error):
        """No trajectory. `status` says which kind of no, the text why; `statistics`: see get_planning_stats."""

        status: Status
        statistics: dict[str, object]
