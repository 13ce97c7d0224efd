"""The estimators: local estimation from chains, direct light, near field, and the batches made of them."""
