"""The last few things that were needed."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Generic, TypeVar

K = TypeVar("K", bound=Hashable)
V = TypeVar("V")


class Recent(Generic[K, V]):
    """Holds the values that were asked for last, up to `capacity`; safe from many threads.

    Threads that ask for the same value at the same time wait for the one that makes it.
    """

    def __init__(self, capacity: int) -> None:
        self._capacity = capacity
        self._lock = threading.Lock()
        self._values: OrderedDict[K, V] = OrderedDict()
        # Locks of those that are being made, and how many threads hold or await each.
        self._making: dict[K, tuple[threading.Lock, int]] = {}

    def get(self, key: K, make: Callable[[], V]) -> V:
        """The value of `key`, which `make` makes if it is not there; what it raises is not kept."""
        with self._lock:
            if key in self._values:
                self._values.move_to_end(key)
                return self._values[key]
            making, waiting = self._making.get(key, (threading.Lock(), 0))
            self._making[key] = making, waiting + 1
        try:
            with making:
                with self._lock:
                    if key in self._values:
                        return self._values[key]
                value = make()
                with self._lock:
                    self._values[key] = value
                    while len(self._values) > self._capacity:
                        self._values.popitem(last=False)
                return value
        finally:
            with self._lock:
                making, waiting = self._making.pop(key)
                if waiting > 1:
                    self._making[key] = making, waiting - 1

    def __len__(self) -> int:
        with self._lock:
            return len(self._values)
