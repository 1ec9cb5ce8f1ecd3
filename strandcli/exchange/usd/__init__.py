"""Curves of USD (https://openusd.org), read and written by a process of their own.

What reads USD is Pixar's library, which is C++ and made for files of people that one trusts: a damaged file may end the
process, print, or never come back. Here it does so in a worker, which is given no more memory and time than a file of
its size needs, and ends when it has had nothing to do for a while.
"""
