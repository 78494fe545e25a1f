"""What several tests of workers run on."""

from collections.abc import Iterator
from concurrent.futures import Executor

import pytest


@pytest.fixture
def cluster() -> Iterator[Executor]:
    """Two workers of dask."""
    distributed = pytest.importorskip("distributed", reason="dask is not installed: pip install '.[dask]'")
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        assert len(client.scheduler_info()["workers"]) == 2
        yield client.get_executor()
