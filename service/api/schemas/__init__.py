"""What requests may say and what answers say, field by field; the OpenAPI document follows.

Requests are strict: no unknown field, no number as text, no truth value as number, no NaN, no
infinity. Times are RFC 3339 in UTC. Answers hold no NaN either: null replaces a number that is not
finite.
"""
