"""Tables that scenario files of several families have, declared key by key."""
