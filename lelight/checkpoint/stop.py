"""Being asked to stop: at once where nothing would be torn, else at the next safe place."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager


class Stop:
    """A request to stop, which whoever has it may make at any time.

    Attributes
    ----------
    asked : whether the request was made
    remark : what to tell a user about it, beside that the run was interrupted
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget the request."""
        self.asked = False
        self.remark = ""
        self._listening = False

    def ask(self) -> None:
        """Make the request, from a signal's handler.

        Raises
        ------
        KeyboardInterrupt
            where the run does not listen for it
        """
        self.asked = True
        if not self._listening:
            raise KeyboardInterrupt

    def check(self) -> None:
        """Stop here, if that was asked for.

        Raises
        ------
        KeyboardInterrupt
        """
        if self.asked:
            raise KeyboardInterrupt

    @contextmanager
    def listening(self) -> Iterator[None]:
        """Within this block requests wait for `check`, which has to be called a few times a second."""
        self._listening = True
        try:
            yield
        finally:
            self._listening = False
        self.check()
