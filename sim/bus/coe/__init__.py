# SPDX-License-Identifier: Apache-2.0
"""The device on the bus (EtherCAT-compatible): its object dictionary and what is made of it."""
