# SPDX-License-Identifier: Apache-2.0
"""The SDO client of python-canopen at the mailbox of a `Host`."""

from canopen import objectdictionary
from canopen.sdo import SdoClient

from tests.ethercat.host import Host


def client_of(host: Host) -> SdoClient:
    """What it sends goes through the mailbox, the answer comes back."""

    class Line:
        def send_message(self, can_id: int, data: bytes, remote: bool = False) -> None:
            answer = host.coe(2, bytes(data))
            found.on_response(0x581, bytearray(answer[:8]), 0.0)

    found = SdoClient(0x601, 0x581, objectdictionary.ObjectDictionary())
    found.network = Line()
    return found
