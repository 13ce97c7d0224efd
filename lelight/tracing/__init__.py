"""What rays and light meet: geometry for embree, emitters, reflection, random numbers, chains of light."""
