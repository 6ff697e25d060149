# SPDX-License-Identifier: Apache-2.0
"""Models that serve TAP devices in a thread of their own end on request."""

import threading

import pytest

from sim.bus.device import DeviceRtl
from sim.bus.line import Line

NO_DEVICE = -1


@pytest.mark.parametrize(
    ("model", "taps"), [(Line, (NO_DEVICE, NO_DEVICE)), (DeviceRtl, (NO_DEVICE,))]
)
def test_stop__before_the_thread_begins__ends_it(model, taps):
    rtl = model()
    rtl._call("restart")
    rtl._call("stop")
    service = threading.Thread(target=rtl._call, args=("serve", *taps), daemon=True)
    service.start()
    service.join(10)
    assert not service.is_alive()


@pytest.mark.parametrize("model", [Line, DeviceRtl])
def test_served_twice__time_goes_on_each_time(model):
    rtl = model()
    for _ in range(2):
        before = rtl.now
        with rtl.served(NO_DEVICE):
            while rtl.now == before:
                pass
