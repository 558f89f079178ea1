"""See robots, scenes and motions: in a browser while you work, and as HTML files that play without a server."""
