in float closeness;
out float colour;

void main() { colour = closeness; }
