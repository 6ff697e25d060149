# SPDX-License-Identifier: Apache-2.0
"""Generated from rtl/ethercat/regmap.rdl."""
