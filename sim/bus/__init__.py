# SPDX-License-Identifier: Apache-2.0
"""The EtherCAT-compatible slave in simulation: registers, model, masters on a TAP device."""
