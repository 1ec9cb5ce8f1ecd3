"""The stability matrix: what a solver does in every corner, judged by thresholds (`strandcli stress`)."""
