# SPDX-License-Identifier: Apache-2.0
"""Self-contained result pages: one HTML file with text, tables, pictures and interactive plots."""
