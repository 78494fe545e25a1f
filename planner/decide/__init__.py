"""What has to go before what, how sure that is, and in which sequence it is safest."""
