"""A flight on a second screen: a web page, served by a process of its own.

The command that flies hands it snapshots and takes its presses (`page`); the process (`server`)
draws them with viser. Nothing that a browser does reaches the process that flies.
"""
