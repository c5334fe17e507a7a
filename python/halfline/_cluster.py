"""Clusters for the command's `--cluster`."""

from __future__ import annotations

import asyncio
import logging
import warnings
from importlib import import_module
from typing import TYPE_CHECKING

from halfline._native import RenderSettings

if TYPE_CHECKING:
    from distributed import Client

    from halfline._progress import Report

_CONNECT_SECONDS = 4


class Cluster:
    """A cluster that answered."""

    def __init__(self, client: Client) -> None:
        self._client = client

    def trace(self, path: str, settings: str, report: Report) -> list[bytes]:
        """All rows of a picture of a tree file.

        Args:
            path: The file.
            settings: The picture's, as JSON.
            report: Called with the stage, what is done of it and the total, and often with zeros
                for both; what it raises ends the work.
        """
        from halfline.dask._render import trace

        try:
            wanted = RenderSettings.from_json(settings)
            return trace(self._client, path, wanted, report, lambda: report("trace", 0, 0))
        finally:
            self._client.close(timeout=1)


def connect(address: str) -> Cluster:
    """Connects to a scheduler; for the command, of which it silences everything but exceptions.

    Raises:
        ImportError: Without Dask.
        RuntimeError: If nobody answers within a few seconds.
    """
    # The command says one line about what goes wrong, and that is in the exception.
    warnings.simplefilter("ignore")
    logging.disable(logging.CRITICAL)
    # This says what is missing, if anything.
    import_module("halfline.dask")
    from distributed import Client

    try:
        # A client that cannot connect takes its time to end; what fails here does not.
        asyncio.run(_reach(address))
        client = Client(address, timeout=_CONNECT_SECONDS, set_as_default=False)
    except Exception as error:
        reason = str(error) or type(error).__name__
        raise RuntimeError(f"no scheduler of Dask answers at {address}: {reason}") from None
    return Cluster(client)


async def _reach(address: str) -> None:
    from distributed.comm import connect
    from distributed.security import Security

    known = Security().get_connection_args("client")
    comm = await connect(address, timeout=_CONNECT_SECONDS, **known)
    await comm.close()
