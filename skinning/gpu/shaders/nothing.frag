// No colour: depth alone, or vertices captured by transform feedback.
void main() {}
